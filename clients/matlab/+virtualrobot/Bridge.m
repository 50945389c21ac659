classdef Bridge < handle
% BRIDGE  A session with a server of rosbridge: WebSocket (RFC 6455), and the operations of its protocol, version 2.
% Nothing goes on by itself: what comes is read while one of these methods waits.
  properties
    Url = '';
    Newest = containers.Map();     % by topic: the message that came last, as its text, and how many have come
    Callbacks = containers.Map();  % by topic: a cell of functions of that text
    Servers = containers.Map();    % by service: a function of request (struct) that gives the response as text
    Goals = containers.Map();      % by id: functions of feedback (struct) of goals under way
    Types = [];
  end
  properties (Access = private)
    Stream = [];
    Replies = containers.Map();
    Number = 0;
    Looked = 0;
  end
  methods
    function self = Bridge(host, port, token, names)
      self.Url = sprintf('ws://%s:%d', host, port);
      self.Newest = containers.Map();  % defaults are shared by all objects of the class
      self.Callbacks = containers.Map();
      self.Servers = containers.Map();
      self.Goals = containers.Map();
      self.Replies = containers.Map();
      self.Types = virtualrobot.Types(self, names);
      self.Stream = virtualrobot.Stream(host, port);
      self.shake(host, port, token);
      self.Looked = virtualrobot.now();
    end

    function tell(self, text)
      % Send an operation, a JSON text.
      self.frame(1, virtualrobot.bytes_of(text));
    end

    function id = new_id(self, kind)
      self.Number = self.Number + 1;
      id = sprintf('%s %d', kind, self.Number);
    end

    function values = call(self, service, asked, timeout)
      % The values that a service answers (struct) to asked, a JSON text; an error where it refuses.
      id = self.new_id('call');
      self.tell(sprintf('{"op":"call_service","id":"%s","service":%s,"args":%s}', id, jsonencode(service), asked));
      reply = self.reply(id, timeout, service);
      if ~reply.result
        error('virtualrobot:service', '%s: %s', service, virtualrobot.words(reply.values));
      end
      values = reply.values;
    end

    function message = reply(self, id, timeout, what)
      % The answer that comes under an id; an error virtualrobot:timeout where none does.
      deadline = virtualrobot.now() + timeout;
      while ~isKey(self.Replies, id)
        if ~self.pump(deadline)
          error('virtualrobot:timeout', '%s has not answered within %g s', what, timeout);
        end
      end
      message = self.Replies(id);
      remove(self.Replies, id);
    end

    function answered = is_answered(self, id)
      answered = isKey(self.Replies, id);
    end

    function catch_up(self)
      % What has piled up is read, so that what follows is new. Where nobody has looked for a while, the server holds
      % messages back, too; what it answers comes after them.
      if virtualrobot.now() - self.Looked > 0.25
        self.call('/rosapi/get_time', '{}', 10);
      end
      last = virtualrobot.now() + 0.5;  % where more comes than can be read
      while self.pump(0) && virtualrobot.now() < last
      end
    end

    function came = pump(self, deadline)
      % Take the next message; false where none has come until then.
      [text, came] = self.message(deadline);
      self.Looked = virtualrobot.now();
      if came
        topic = regexp(text(1:min(end, 400)), '^\s*\{"op":\s*"publish",\s*"topic":\s*"([^"]+)"', 'tokens', 'once');
        if isempty(topic)
          self.take(jsondecode(text));
        else
          self.publish(topic{1}, text);
        end
      end
    end

    function close(self)
      if ~isempty(self.Stream)
        try
          self.frame(8, zeros(1, 0, 'uint8'));
        catch
        end
        self.Stream.close();
        self.Stream = [];
      end
    end

    function open = is_open(self)
      open = ~isempty(self.Stream);
    end
  end
  methods (Access = private)
    function shake(self, host, port, token)
      lines = {'GET / HTTP/1.1', sprintf('Host: %s:%d', host, port), 'Upgrade: websocket', 'Connection: Upgrade', ...
               'Sec-WebSocket-Key: dmlydHVhbHJvYm90cm9zLg==', 'Sec-WebSocket-Version: 13'};
      if ~isempty(token)
        lines{end + 1} = ['Authorization: Bearer ' token];
      end
      self.Stream.write(uint8([sprintf('%s\r\n', lines{:}), sprintf('\r\n')]));
      deadline = virtualrobot.now() + 10;
      status = self.Stream.line(deadline);
      said = status;
      while ischar(said) && ~isempty(strtrim(said))
        said = self.Stream.line(deadline);
      end
      if ~ischar(said) || isempty(strfind(status, ' 101 '))
        said = '';
        if ischar(status)
          said = strtrim([strtrim(status), ' ', self.Stream.line(virtualrobot.now() + 1)]);
        end
        self.Stream.close();
        self.Stream = [];
        error('virtualrobot:connection', '%s is no server of rosbridge, or refuses: %s', self.Url, said);
      end
    end

    function frame(self, operation, bytes)
      if isempty(self.Stream)
        error('virtualrobot:connection', 'there is no connection; call rosinit first');
      end
      count = numel(bytes);
      if count < 126
        size = uint8(128 + count);
      elseif count < 65536
        size = uint8([254, floor(count / 256), mod(count, 256)]);
      else
        size = uint8([255, mod(floor(count ./ 256 .^ (7:-1:0)), 256)]);
      end
      % Clients have to mask what they send; a mask of zeros leaves it as it is.
      self.Stream.write([uint8(128 + operation), size, zeros(1, 4, 'uint8'), bytes]);
    end

    function [text, came] = message(self, deadline)
      % The next message, a text; pings that come meanwhile are answered.
      if isempty(self.Stream)
        error('virtualrobot:connection', 'there is no connection; call rosinit first');
      end
      parts = zeros(1, 0, 'uint8');
      while true
        [first, bytes] = self.next_frame(deadline);
        came = ~isempty(first);
        if ~came
          text = '';
          return
        end
        switch mod(first, 16)
          case 8
            self.close();
            error('virtualrobot:connection', '%s has closed the connection: %s', self.Url, char(bytes(3:end)));
          case 9
            self.frame(10, bytes);
          case {0, 1, 2}
            parts = [parts, bytes];
            if first >= 128
              text = virtualrobot.text_of(parts);
              return
            end
            deadline = virtualrobot.now() + 10;
        end
      end
    end

    function [first, bytes] = next_frame(self, deadline)
      first = [];
      bytes = zeros(1, 0, 'uint8');
      head = double(self.Stream.peek(2, deadline));
      if isempty(head)
        return
      end
      more = 0;
      if head(2) >= 126
        more = 2 + 6 * (head(2) == 127);
        head = double(self.Stream.peek(2 + more, deadline));
        if isempty(head)
          return
        end
      end
      count = head(2);
      if more > 0
        count = sum(head(3:end) .* 256 .^ (more - 1:-1:0));
      end
      whole = self.Stream.take(2 + more + count, deadline);
      if ~isempty(whole)
        first = head(1);
        bytes = whole(3 + more:end);
      end
    end

    function publish(self, topic, text)
      count = 1;
      if isKey(self.Newest, topic)
        before = self.Newest(topic);
        count = before.count + 1;
      end
      newest = self.Newest;
      newest(topic) = struct('count', count, 'text', text);
      if isKey(self.Callbacks, topic)
        called = self.Callbacks(topic);
        for place = 1:numel(called)
          called{place}(text);
        end
      end
    end

    function take(self, message)
      switch message.op
        case {'service_response', 'action_result'}
          replies = self.Replies;
          replies(message.id) = message;
        case 'action_feedback'
          if isKey(self.Goals, message.id)
            hear = self.Goals(message.id);
            hear(message.values);
          end
        case 'call_service'
          self.serve(message);
        case 'status'
          if isfield(message, 'id') && ischar(message.id) && ~isempty(message.id)
            replies = self.Replies;
            replies(message.id) = struct('result', false, 'values', message.msg, 'status', 6);
          end
          if strcmp(message.level, 'error')
            error('virtualrobot:refused', '%s', message.msg);
          end
          warning('virtualrobot:status', '%s', message.msg);
      end
    end

    function serve(self, asked)
      result = 'true';
      try
        answer = self.Servers(asked.service);
        values = answer(asked.args);
      catch problem
        result = 'false';
        values = jsonencode(problem.message);
      end
      self.tell(sprintf('{"op":"service_response","id":"%s","service":%s,"values":%s,"result":%s}', ...
                        asked.id, jsonencode(asked.service), values, result));
    end
  end
end
