classdef ParameterTree < handle
% PARAMETERTREE  What rosparam gives; its help tells how it is used.
  properties (Access = private)
    Bridge = [];
  end
  properties (Dependent)
    AvailableParameters
  end
  methods
    function self = ParameterTree()
      self.Bridge = virtualrobot.session();
    end

    function names = get.AvailableParameters(self)
      names = virtualrobot.ask('get_param_names', 'names');
    end

    function value = get(self, name)
      told = self.Bridge.call('/rosapi/get_param', sprintf('{"name":%s}', jsonencode(char(name))), 10);
      value = jsondecode(told.value);
    end

    function set(self, name, value)
      self.Bridge.call('/rosapi/set_param', sprintf('{"name":%s,"value":%s}', jsonencode(char(name)), ...
                                                   jsonencode(jsonencode(value))), 10);
    end

    function there = has(self, name)
      told = self.Bridge.call('/rosapi/has_param', sprintf('{"name":%s}', jsonencode(char(name))), 10);
      there = told.exists;
    end

    function del(self, name)
      self.Bridge.call('/rosapi/delete_param', sprintf('{"name":%s}', jsonencode(char(name))), 10);
    end
  end
end
