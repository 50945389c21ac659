function told = rosservice(verb, service)
% ROSSERVICE  `rosservice list`, `rosservice type SERVICE`.
  if nargin < 1 || ~any(strcmp(verb, {'list', 'type'})) || (nargin < 2) ~= strcmp(verb, 'list')
    error('virtualrobot:usage', 'rosservice list, or rosservice type SERVICE');
  end
  if strcmp(verb, 'list')
    found = virtualrobot.show(sort(virtualrobot.ask('services', 'services')), nargout > 0);
  else
    found = virtualrobot.service_type(service);
    if nargout == 0
      fprintf('%s\n', found);
    end
  end
  if nargout > 0
    told = found;
  end
end
