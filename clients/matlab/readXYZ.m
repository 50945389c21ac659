function points = readXYZ(cloud)
% READXYZ  Points (m) of a message sensor_msgs/PointCloud2, in its frame: n x 3.
  [width, step, data, fields] = virtualrobot.raw_of(cloud, {'width', 'point_step', 'data', 'fields'});
  height = virtualrobot.raw_of(cloud, {'height'});
  count = width * height;
  rows = reshape(data(1:step * count), step, count);
  points = zeros(count, 3);
  names = {'x', 'y', 'z'};
  for axis = 1:3
    place = find(strcmp(arrayfun(@(one) virtualrobot.raw_of(one, {'name'}), fields, 'UniformOutput', false), names{axis}));
    [offset, kind] = virtualrobot.raw_of(fields(place), {'offset', 'datatype'});
    kinds = {'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'single', 'double'};
    sizes = [1 1 2 2 4 4 4 8];
    bytes = rows(offset + (1:sizes(kind)), :);
    points(:, axis) = double(typecast(reshape(bytes, 1, []), kinds{kind}))';
  end
end
