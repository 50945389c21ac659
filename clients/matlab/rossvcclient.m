function [client, request] = rossvcclient(service, varargin)
% ROSSVCCLIENT  A client of a service.
%   [client, request] = rossvcclient('/rosapi/topic_type')
%   request.Topic = '/odom';
%   response = call(client, request)
%   response = call(client, request, 'Timeout', 3)
  client = virtualrobot.ServiceClient(service, varargin{:});
  if nargout > 1
    request = rosmessage(client);
  end
end
