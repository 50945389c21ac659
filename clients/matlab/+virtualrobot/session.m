function bridge = session(varargin)
% SESSION  The connection that rosinit has opened; with an argument it becomes this one, [] for none.
  persistent current
  if nargin > 0
    current = varargin{1};
  elseif isempty(current) || ~current.is_open()
    error('virtualrobot:connection', 'there is no connection; call rosinit first');
  end
  bridge = current;
end
