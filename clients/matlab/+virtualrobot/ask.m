function found = ask(service, key, varargin)
% ASK  What a service of rosapi tells under a key, as a column of texts; ASK(service, key, name, value) with a request.
  asked = '{}';
  if nargin > 2
    asked = sprintf('{"%s":%s}', varargin{1}, jsonencode(char(varargin{2})));
  end
  bridge = virtualrobot.session();
  told = bridge.call(['/rosapi/' service], asked, 10);
  found = told.(key);
  if isempty(found)
    found = {};
  end
  found = reshape(cellstr(found), [], 1);
end
