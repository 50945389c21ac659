function told = rosparam(verb, name, value)
% ROSPARAM  Parameters that all clients share.
%   tree = rosparam; names = tree.AvailableParameters
%   set(tree, '/arm/speed', 0.5); get(tree, '/arm/speed'); has(tree, '/arm/speed'); del(tree, '/arm/speed')
% A namespace, get(tree, '/arm'), is a struct.
% As a command: `rosparam list`, rosparam('get', NAME), rosparam('set', NAME, VALUE), rosparam('delete', NAME).
  tree = virtualrobot.ParameterTree();
  if nargin == 0
    told = tree;
    return
  end
  counts = struct('list', 1, 'get', 2, 'set', 3, 'delete', 2);
  if ~isfield(counts, verb) || nargin ~= counts.(verb)
    error('virtualrobot:usage', 'rosparam list, or rosparam get NAME, set NAME VALUE, delete NAME');
  end
  switch verb
    case 'list'
      found = virtualrobot.show(tree.AvailableParameters, nargout > 0);
    case 'get'
      found = get(tree, name);
      if nargout == 0
        disp(found);
      end
    case 'set'
      set(tree, name, value);
    case 'delete'
      del(tree, name);
  end
  if nargout > 0
    told = found;
  end
end
