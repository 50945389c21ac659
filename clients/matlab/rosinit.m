function rosinit(varargin)
% ROSINIT  Connect to a server of rosbridge, such as `virtualrobot ros`.
%   rosinit                       the one of this machine, port 9090
%   rosinit('10.0.0.7')           another machine's
%   rosinit('10.0.0.7', 9091)     with its port
%   rosinit('ws://10.0.0.7:9091')
%   rosinit(..., 'Token', token)       where clients need one
%   rosinit(..., 'FieldNames', 'ros')  fields are called as in ROS (angle_min), not as in ROS Toolbox (AngleMin)
  host = '127.0.0.1';
  port = 9090;
  token = '';
  names = 'matlab';
  given = cellfun(@plain, varargin, 'UniformOutput', false);
  place = 1;
  while place <= numel(given)
    one = given{place};
    if any(strcmpi(one, {'Token', 'FieldNames'})) && place < numel(given)
      place = place + 1;
      if strcmpi(one, 'Token')
        token = given{place};
      else
        names = given{place};
      end
    elseif isnumeric(one)
      port = one;
    elseif place == 1
      found = regexp(one, '^(?:ws|http)://\[?([^\]/]+?)\]?(?::(\d+))?/?$', 'tokens', 'once');
      host = one;
      if ~isempty(found)
        host = found{1};
        if numel(found) > 1 && ~isempty(found{2})
          port = str2double(found{2});
        end
      end
    else
      error('virtualrobot:usage', 'rosinit takes a host, a port, ''Token'' and ''FieldNames'', not ''%s''', one);
    end
    place = place + 1;
  end
  if ~any(strcmp(names, {'matlab', 'ros'}))
    error('virtualrobot:usage', '''FieldNames'' is ''matlab'' or ''ros'', not ''%s''', names);
  end
  if ~isscalar(port) || port ~= round(port) || port < 1 || port > 65535
    error('virtualrobot:usage', 'a port is a whole number from 1 to 65535');
  end
  try
    before = virtualrobot.session();
  catch
    before = [];
  end
  if ~isempty(before)
    error('virtualrobot:connection', 'there is a connection to %s already; rosshutdown ends it', before.Url);
  end
  bridge = virtualrobot.Bridge(host, port, token, names);
  virtualrobot.session(bridge);
  fprintf('Connected to %s\n', bridge.Url);
end

function value = plain(value)
  if ~isnumeric(value)
    value = char(value);
  end
end
