function image = readImage(message)
% READIMAGE  The pixels of a message sensor_msgs/Image: height x width (x 3); rgb8, bgr8, mono8, 16UC1, 32FC1, 32SC1.
  [height, width, encoding, step, data] = virtualrobot.raw_of(message, {'height', 'width', 'encoding', 'step', 'data'});
  known = {'rgb8', 'bgr8', 'mono8', '8UC1', '16UC1', 'mono16', '32FC1', '32SC1', '32FC3'};
  kinds = {'uint8', 'uint8', 'uint8', 'uint8', 'uint16', 'uint16', 'single', 'int32', 'single'};
  depths = [3 3 1 1 1 1 1 1 3];
  place = find(strcmp(encoding, known));
  if isempty(place)
    error('virtualrobot:message', 'images of ''%s'' are not read; known: %s', encoding, strjoin(known, ', '));
  end
  values = typecast(reshape(data(1:step * height), 1, []), kinds{place});
  values = reshape(values, [], height);
  values = values(1:width * depths(place), :);
  image = permute(reshape(values, depths(place), width, height), [3 2 1]);
  if strcmp(encoding, 'bgr8')
    image = image(:, :, [3 2 1]);
  end
end
