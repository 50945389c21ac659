function varargout = raw_of(message, names)
% RAW_OF  Fields of a message by their names in ROS, however they are called.
  varargout = cell(1, numel(names));
  for place = 1:numel(names)
    name = names{place};
    if ~isfield(message, name)
      parts = strsplit(name, '_');
      name = strjoin(cellfun(@(one) [upper(one(1)), one(2:end)], parts, 'UniformOutput', false), '');
    end
    if ~isfield(message, name)
      error('virtualrobot:message', 'this message has no field %s', name);
    end
    varargout{place} = message.(name);
  end
end
