function nodes = rosnode(verb)
% ROSNODE  `rosnode list`: the nodes that there are.
  if nargin < 1 || ~strcmp(verb, 'list')
    error('virtualrobot:usage', 'rosnode list');
  end
  found = virtualrobot.show(sort(virtualrobot.ask('nodes', 'nodes')), nargout > 0);
  if nargout > 0
    nodes = found;
  end
end
