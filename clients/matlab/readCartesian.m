function points = readCartesian(scan, varargin)
% READCARTESIAN  Where the beams of a sensor_msgs/LaserScan end, in its frame (m): n x 2, x forward, y to the left.
% Beams without an echo are left out. READCARTESIAN(scan, 'RangeLimits', [least most]) takes other limits of range.
  [~, ~, ranges, limits] = virtualrobot.scan_of(scan);
  if numel(varargin) == 2 && strcmpi(varargin{1}, 'RangeLimits')
    limits = varargin{2};
  end
  angles = readScanAngles(scan);
  good = isfinite(ranges) & ranges >= limits(1) & ranges <= limits(2);
  points = [ranges(good) .* cos(angles(good)), ranges(good) .* sin(angles(good))];
end
