classdef lockstep < handle
% LOCKSTEP  The way to `virtualrobot lockstep ROBOT --port 5600`: time waits for each command.
%   link = lockstep(5600)
%   state = receive(link)                          what docs/lockstep.md tells; [] when the run is over
%   send(link, struct('twist', [0.3 0 0.1]))       or positions, velocities, signals, done
  properties (Access = private)
    Stream = [];
  end
  methods
    function self = lockstep(port, host)
      if nargin < 2
        host = '127.0.0.1';
      end
      self.Stream = virtualrobot.Stream(host, port);
    end

    function state = receive(self, timeout)
      % The next state (struct); an error virtualrobot:timeout where none comes in time (60 s without one).
      if nargin < 2
        timeout = 60;
      end
      state = [];
      try
        text = self.Stream.line(virtualrobot.now() + timeout);
      catch problem
        if strcmp(problem.identifier, 'virtualrobot:connection')
          return
        end
        rethrow(problem);
      end
      if ~ischar(text)
        error('virtualrobot:timeout', 'no state came within %g s', timeout);
      end
      state = jsondecode(text);
    end

    function send(self, command)
      % Send a command (struct); numbers go with all of their digits.
      names = fieldnames(command);
      text = '';
      for place = 1:numel(names)
        value = command.(names{place});
        if isnumeric(value)
          part = sprintf('%.17g,', value);
          part = ['[' part(1:end - 1) ']'];
        else
          part = jsonencode(value);
        end
        text = [text ',"' names{place} '":' part];
      end
      text(1) = '{';  % in place of a comma
      self.Stream.write(virtualrobot.bytes_of([text '}' char(10)]));
    end

    function close(self)
      self.Stream.close();
    end
  end
end
