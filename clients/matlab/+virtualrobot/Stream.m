classdef Stream < handle
% STREAM  Bytes to a server and back over TCP: by tcpclient where there is one (MATLAB, Octave's package
% instrument-control), else, in plain Octave, by bash, which can open a connection, and two pipes to it.
  properties
    Place = '';
  end
  properties (Access = private)
    Socket = [];
    In = -1;
    Out = -1;
    Process = -1;
    Rest = zeros(1, 0, 'uint8');
    At = 0;
  end
  methods
    function self = Stream(host, port)
      % Connect; error virtualrobot:connection where nobody serves.
      self.Place = sprintf('%s:%d', host, port);
      if exist('OCTAVE_VERSION', 'builtin') && isempty(which('tcpclient'))
        if isunix()
          self.open_by_bash(host, port);
          return
        end
        pkg('load', 'instrument-control');
      end
      try
        self.Socket = tcpclient(host, port);
      catch problem
        error('virtualrobot:connection', 'nobody serves at %s: %s', self.Place, problem.message);
      end
    end

    function write(self, bytes)
      % Send bytes, a row of uint8.
      if isempty(self.Socket)
        fwrite(self.In, bytes);
        fflush(self.In);
      else
        write(self.Socket, bytes);
      end
    end

    function bytes = take(self, count, deadline)
      % The next so many bytes, a row of uint8; empty where they have not all come until then (toc of a tic, see now).
      while numel(self.Rest) - self.At < count
        if ~self.wait(deadline)
          bytes = [];
          return
        end
      end
      bytes = self.Rest(self.At + 1:self.At + count);
      self.At = self.At + count;
    end

    function bytes = peek(self, count, deadline)
      % The same, but they stay.
      bytes = self.take(count, deadline);
      self.At = self.At - numel(bytes);
    end

    function text = line(self, deadline)
      % The next line without its end; [] where none has come until then.
      searched = self.At;
      while true
        found = find(self.Rest(searched + 1:end) == 10, 1);
        if ~isempty(found)
          text = virtualrobot.text_of(self.Rest(self.At + 1:searched + found - 1));
          self.At = searched + found;
          return
        end
        waiting = numel(self.Rest) - self.At;
        if ~self.wait(deadline)
          text = [];
          return
        end
        searched = self.At + waiting;
      end
    end

    function close(self)
      % Close it; a second time does nothing.
      if ~isempty(self.Socket)
        delete(self.Socket);
        self.Socket = [];
      elseif self.Process > 0
        fclose(self.In);
        fclose(self.Out);
        waitpid(self.Process);
        self.Process = -1;
      end
    end
  end
  methods (Access = private)
    function open_by_bash(self, host, port)
      if isempty(regexp(host, '^[A-Za-z0-9.:_-]+$', 'once'))
        error('virtualrobot:connection', '''%s'' is no name of a host', host);
      end
      % What comes goes on to the pipe by the last cat; when the pipe from here is closed, it is ended.
      script = sprintf(['exec 3<>/dev/tcp/%s/%d 4<&0 || exit 1; echo; ' ...
                        '{ cat <&4 >&3; kill $$; } & exec cat <&3'], host, port);
      [self.In, self.Out, self.Process] = popen2('bash', {'-c', ['exec 2>/dev/null; ' script]});
      try
        connected = ~isempty(self.take(1, virtualrobot.now() + 10));
      catch
        connected = false;  % bash has ended, as nobody has taken its connection
      end
      if ~connected
        self.close();
        error('virtualrobot:connection', 'nobody serves at %s', self.Place);
      end
    end

    function came = wait(self, deadline)
      % Read what has come, or wait for some; false where nothing has come until then.
      misses = 0;
      while true
        if isempty(self.Socket)
          bytes = fread(self.Out, 65536, 'uint8=>uint8')';
          fclear(self.Out);
        else
          bytes = self.read_socket();
        end
        came = ~isempty(bytes);
        % Calls take long in Octave, so whether the time or the process is over is asked at every eighth look.
        if ~came && mod(misses, 8) == 0
          if isempty(self.Socket) && self.has_ended()
            bytes = fread(self.Out, 65536, 'uint8=>uint8')';
            if isempty(bytes)
              error('virtualrobot:connection', 'the connection to %s has ended', self.Place);
            end
            came = true;
          elseif virtualrobot.now() >= deadline
            return
          end
        end
        if came
          self.Rest = [self.Rest(self.At + 1:end), bytes];
          self.At = 0;
          return
        end
        misses = misses + 1;
        pause(0.0002 + 0.0008 * (misses > 16));  % whoever takes longer shall not be kept from it
      end
    end

    function bytes = read_socket(self)
      try
        count = self.Socket.NumBytesAvailable;
        bytes = zeros(1, 0, 'uint8');
        if count > 0
          bytes = uint8(reshape(read(self.Socket, count), 1, []));
        end
      catch problem
        error('virtualrobot:connection', 'the connection to %s has ended: %s', self.Place, problem.message);
      end
    end

    function ended = has_ended(self)
      ended = self.Process < 0;
      if ~ended && waitpid(self.Process, WNOHANG()) == self.Process
        self.Process = -1;
        fclose(self.In);
        ended = true;
      end
    end
  end
end
