classdef Subscriber < handle
% SUBSCRIBER  What rossubscriber gives; its help tells how it is used.
  properties
    TopicName = '';
    MessageType = '';
    NewMessageFcn = [];
  end
  properties (Access = private)
    Bridge = [];
    Id = '';
  end
  properties (Dependent)
    LatestMessage
  end
  methods
    function self = Subscriber(topic, varargin)
      self.TopicName = char(topic);
      self.Bridge = virtualrobot.session();
      for place = 1:numel(varargin)
        if isa(varargin{place}, 'function_handle')
          self.NewMessageFcn = varargin{place};
        else
          self.MessageType = char(varargin{place});
        end
      end
      if isempty(self.MessageType)
        self.MessageType = virtualrobot.topic_type(self.TopicName);
      end
      self.Bridge.Types.blank(self.MessageType, '');  % so that its fields are known before the first one comes
      if ~isempty(self.NewMessageFcn)
        callbacks = self.Bridge.Callbacks;
        called = {};
        if isKey(callbacks, self.TopicName)
          called = callbacks(self.TopicName);
        end
        callbacks(self.TopicName) = [called, {@(text) self.subscriber_hears(text)}];
      end
      self.Id = self.Bridge.new_id('subscribe');
      self.Bridge.tell(sprintf('{"op":"subscribe","id":"%s","topic":%s,"type":%s}', self.Id, ...
                               jsonencode(self.TopicName), jsonencode(self.MessageType)));
    end

    function [message, status, text] = receive(self, timeout)
      % The next message that comes. Without one within the timeout (s; as long as it takes without one) an error
      % virtualrobot:timeout, or status false and why in text, where they are asked for.
      if nargin < 2
        timeout = Inf;
      end
      deadline = virtualrobot.now() + timeout;
      self.Bridge.catch_up();
      before = self.messages_so_far();
      message = [];
      status = true;
      text = 'success';
      while self.messages_so_far() == before
        if ~self.Bridge.pump(deadline)
          status = false;
          text = sprintf('nothing came on %s within %g s', self.TopicName, timeout);
          if nargout < 2
            error('virtualrobot:timeout', '%s', text);
          end
          return
        end
      end
      message = self.newest_message();
    end

    function message = get.LatestMessage(self)
      % The message that came last, [] where none has.
      while self.Bridge.pump(0)
      end
      message = self.newest_message();
    end

    function type = type_name(self)
      type = self.MessageType;
    end

    function unsubscribe(self)
      % Hear no more.
      self.Bridge.tell(sprintf('{"op":"unsubscribe","id":"%s","topic":%s}', self.Id, jsonencode(self.TopicName)));
    end
  end
  methods (Access = private)
    % Octave takes a method for the user's function of the same name, so these have names that nobody gives.
    function subscriber_hears(self, text)
      self.NewMessageFcn(self, self.decoded_message(text));
    end

    function count = messages_so_far(self)
      count = 0;
      if isKey(self.Bridge.Newest, self.TopicName)
        newest = self.Bridge.Newest(self.TopicName);
        count = newest.count;
      end
    end

    function message = newest_message(self)
      message = [];
      if isKey(self.Bridge.Newest, self.TopicName)
        newest = self.Bridge.Newest(self.TopicName);
        message = self.decoded_message(newest.text);
      end
    end

    function message = decoded_message(self, text)
      plain = jsondecode(text);
      message = self.Bridge.Types.decode(plain.msg, self.MessageType, '');
    end
  end
end
