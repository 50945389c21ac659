function [least, step, ranges, limits] = scan_of(scan)
% SCAN_OF  First angle and step (rad), ranges and their limits (m) of a scan, however its fields are called.
  if isfield(scan, 'AngleMin')
    least = scan.AngleMin;
    step = scan.AngleIncrement;
    ranges = scan.Ranges;
    limits = [scan.RangeMin, scan.RangeMax];
  elseif isfield(scan, 'angle_min')
    least = scan.angle_min;
    step = scan.angle_increment;
    ranges = scan.ranges;
    limits = [scan.range_min, scan.range_max];
  else
    error('virtualrobot:message', 'a message sensor_msgs/LaserScan belongs here');
  end
  ranges = double(ranges(:));
end
