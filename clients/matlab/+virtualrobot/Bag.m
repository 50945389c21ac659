classdef Bag < handle
% BAG  What rosbag gives; its help tells how it is used.
  properties
    FilePath = '';
    StartTime = 0;
    EndTime = 0;
    NumMessages = 0;
    AvailableTopics = [];
    Times = [];
  end
  properties (Access = private)
    Python = 'python3';
    Names = 'matlab';
    Topics = {};
    Span = [-Inf Inf];
    Lines = [];
  end
  methods
    function self = Bag(file, varargin)
      self.FilePath = char(file);
      for place = 1:2:numel(varargin)
        switch char(varargin{place})
          case 'Python'
            self.Python = char(varargin{place + 1});
          case 'FieldNames'
            self.Names = char(varargin{place + 1});
          otherwise
            error('virtualrobot:usage', 'rosbag takes ''Python'' and ''FieldNames'', not ''%s''', varargin{place});
        end
      end
      lines = self.read('');
      head = jsondecode(lines{1});
      self.StartTime = head.first;
      self.EndTime = head.last;
      self.AvailableTopics = head.topics;
      self.NumMessages = sum([head.topics.count]);
      self.Topics = {head.topics.topic};
    end

    function chosen = select(self, varargin)
      % The same bag with some of its topics, 'Topic' (a text or a cell of them), and times, 'Time' ([from to], s).
      chosen = virtualrobot.Bag(self.FilePath, 'Python', self.Python, 'FieldNames', self.Names);
      topics = self.Topics;
      span = self.Span;
      for place = 1:2:numel(varargin)
        switch char(varargin{place})
          case 'Topic'
            topics = cellstr(varargin{place + 1});
          case 'Time'
            span = varargin{place + 1};
          otherwise
            error('virtualrobot:usage', 'select takes ''Topic'' and ''Time'', not ''%s''', varargin{place});
        end
      end
      chosen.choose(topics, span);
    end

    function messages = readMessages(self, rows)
      % The messages in the order of their times, or some rows of them: a cell of structs.
      if isempty(self.Lines)
        self.choose(self.Topics, self.Span);
      end
      head = jsondecode(self.Lines{1});
      types = virtualrobot.Types([], self.Names);
      for place = 1:numel(head.types)
        types.learn(head.types(place).typedefs, '');
      end
      if nargin < 2
        rows = 1:numel(self.Lines) - 1;
      end
      messages = cell(numel(rows), 1);
      for place = 1:numel(rows)
        told = jsondecode(self.Lines{rows(place) + 1});
        found = head.topics(strcmp({head.topics.topic}, told.topic));
        messages{place} = types.decode(told.msg, found.type, '');
      end
    end

    function choose(self, topics, span)
      % Keep only some topics, and what lies in a span of time (s).
      missing = setdiff(topics, {self.AvailableTopics.topic});
      if ~isempty(missing)
        error('virtualrobot:name', '%s has no topic ''%s''; it has %s', self.FilePath, missing{1}, ...
              strjoin({self.AvailableTopics.topic}, ', '));
      end
      asked = sprintf(' --topic "%s"', topics{:});
      if isfinite(span(1))
        asked = sprintf('%s --start=%.17g', asked, span(1));
      end
      if isfinite(span(2))
        asked = sprintf('%s --end=%.17g', asked, span(2));
      end
      self.Topics = topics;
      self.Span = span;
      self.Lines = self.read(asked);
      told = regexp(self.Lines(2:end), '"time": ([-0-9.e+]+)', 'tokens', 'once');
      self.Times = cellfun(@(one) str2double(one{1}), reshape(told, [], 1));
      self.NumMessages = numel(self.Lines) - 1;
    end
  end
  methods (Access = private)
    function lines = read(self, asked)
      [status, said] = system(sprintf('%s -m virtualrobot_apps.bridges.ros.bag%s -- %s 2>&1', quoted(self.Python), ...
                                      asked, quoted(self.FilePath)));
      if status ~= 0
        error('virtualrobot:bag', '%s', regexprep(strtrim(said), '^(.*\n)?Error: ', ''));
      end
      lines = strsplit(strtrim(said), sprintf('\n'));
      lines = lines(strncmp(lines, '{', 1));  % warnings of Python come the same way
    end
  end
end

function text = quoted(word)
% A word as the system's shell takes it.
  if isunix()
    text = ['''' strrep(word, '''', '''\''''') ''''];
  else
    text = ['"' word '"'];
  end
end
