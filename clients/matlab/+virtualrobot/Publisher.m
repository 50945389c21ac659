classdef Publisher < handle
% PUBLISHER  What rospublisher gives; its help tells how it is used.
  properties
    TopicName = '';
    MessageType = '';
  end
  properties (Access = private)
    Bridge = [];
  end
  methods
    function self = Publisher(topic, type)
      self.TopicName = char(topic);
      self.Bridge = virtualrobot.session();
      if nargin < 2
        type = virtualrobot.topic_type(self.TopicName);
      end
      self.MessageType = char(type);
      self.Bridge.Types.blank(self.MessageType, '');
      self.Bridge.tell(sprintf('{"op":"advertise","topic":%s,"type":%s}', jsonencode(self.TopicName), ...
                               jsonencode(self.MessageType)));
    end

    function send(self, message)
      % Publish a message.
      self.Bridge.tell(sprintf('{"op":"publish","topic":%s,"msg":%s}', jsonencode(self.TopicName), ...
                               self.Bridge.Types.encode(message, self.MessageType, '')));
    end

    function type = type_name(self)
      type = self.MessageType;
    end

    function unadvertise(self)
      % Publish no more.
      self.Bridge.tell(sprintf('{"op":"unadvertise","topic":%s}', jsonencode(self.TopicName)));
    end
  end
end
