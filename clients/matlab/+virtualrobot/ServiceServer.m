classdef ServiceServer < handle
% SERVICESERVER  What rossvcserver gives; its help tells how it is used.
  properties
    ServiceName = '';
    ServiceType = '';
    NewRequestFcn = [];
  end
  properties (Access = private)
    Bridge = [];
  end
  methods
    function self = ServiceServer(service, type, answer)
      self.ServiceName = char(service);
      self.ServiceType = char(type);
      self.NewRequestFcn = answer;
      self.Bridge = virtualrobot.session();
      self.Bridge.Types.blank(self.ServiceType, 'request');
      self.Bridge.Types.blank(self.ServiceType, 'response');
      servers = self.Bridge.Servers;
      servers(self.ServiceName) = @(plain) self.text_for_request(plain);
      self.Bridge.tell(sprintf('{"op":"advertise_service","service":%s,"type":%s}', jsonencode(self.ServiceName), ...
                               jsonencode(self.ServiceType)));
    end

    function close(self)
      % Serve it no more.
      self.Bridge.tell(sprintf('{"op":"unadvertise_service","service":%s}', jsonencode(self.ServiceName)));
    end

    function text = text_for_request(self, plain)
      types = self.Bridge.Types;
      request = types.decode(plain, self.ServiceType, 'request');
      response = self.NewRequestFcn(self, request, types.blank(self.ServiceType, 'response'));
      text = types.encode(response, self.ServiceType, 'response');
    end
  end
end
