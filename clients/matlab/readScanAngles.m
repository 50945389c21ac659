function angles = readScanAngles(scan)
% READSCANANGLES  The angles (rad) of the beams of a message sensor_msgs/LaserScan, a column.
  [least, step, ranges] = virtualrobot.scan_of(scan);
  angles = least + step * (0:numel(ranges) - 1)';
end
