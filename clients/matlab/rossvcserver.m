function server = rossvcserver(service, type, answer)
% ROSSVCSERVER  A service of one's own.
%   server = rossvcserver('/lamp', 'std_srvs/SetBool', @answer)
%   function response = answer(server, request, response)
% The function is called while rosspin, receive or another call waits; an error that it raises is told to the caller.
  server = virtualrobot.ServiceServer(service, type, answer);
end
