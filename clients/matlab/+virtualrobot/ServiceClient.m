classdef ServiceClient < handle
% SERVICECLIENT  What rossvcclient gives; its help tells how it is used.
  properties
    ServiceName = '';
    ServiceType = '';
  end
  properties (Access = private)
    Bridge = [];
  end
  methods
    function self = ServiceClient(service, type)
      self.ServiceName = char(service);
      self.Bridge = virtualrobot.session();
      if nargin < 2
        type = virtualrobot.service_type(self.ServiceName);
      end
      self.ServiceType = char(type);
      self.Bridge.Types.blank(self.ServiceType, 'request');
    end

    function response = call(self, request, varargin)
      % The response; an error virtualrobot:service where the service refuses, virtualrobot:timeout after 60 s without.
      asked = '{}';
      if nargin > 1
        asked = self.Bridge.Types.encode(request, self.ServiceType, 'request');
      end
      timeout = 60;
      if numel(varargin) == 2
        timeout = varargin{2};
      end
      values = self.Bridge.call(self.ServiceName, asked, timeout);
      response = self.Bridge.Types.decode(values, self.ServiceType, 'response');
    end

    function type = type_name(self)
      type = self.ServiceType;
    end
  end
end
