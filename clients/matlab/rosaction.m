function told = rosaction(verb, action)
% ROSACTION  `rosaction list`, `rosaction type ACTION`.
  if nargin < 1 || ~any(strcmp(verb, {'list', 'type'})) || (nargin < 2) ~= strcmp(verb, 'list')
    error('virtualrobot:usage', 'rosaction list, or rosaction type ACTION');
  end
  if strcmp(verb, 'list')
    found = virtualrobot.show(sort(virtualrobot.ask('action_servers', 'action_servers')), nargout > 0);
  else
    found = virtualrobot.ask('action_type', 'type', 'action', action);
    if isempty(found)
      error('virtualrobot:name', 'there is no action ''%s''; rosaction list tells them', action);
    end
    found = found{1};
    if nargout == 0
      fprintf('%s\n', found);
    end
  end
  if nargout > 0
    told = found;
  end
end
