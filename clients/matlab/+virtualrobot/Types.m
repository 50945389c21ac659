classdef Types < handle
% TYPES  Types of messages, asked of rosapi once each, and messages as structs and as JSON.
% Fields are called as in ROS Toolbox, 'AngleMin' for 'angle_min', or with names 'ros' as in ROS.
  properties (Access = private)
    Bridge = [];
    Names = 'matlab';
    Known = containers.Map();
  end
  methods
    function self = Types(bridge, names)
      self.Bridge = bridge;
      self.Names = names;
      self.Known = containers.Map();
    end

    function value = blank(self, type, part)
      % A message of zeros and empty texts. PART is '' of a message, else 'request', 'response', 'goal', 'result'
      % or 'feedback' of a service or an action.
      value = self.made(self.find(type, part), type);
    end

    function value = decode(self, plain, type, part)
      % The message that JSON says, as a struct.
      value = self.read(plain, self.find(type, part));
    end

    function text = encode(self, value, type, part)
      % A message as JSON; an error virtualrobot:message for a field that the type has not.
      text = self.written(value, self.find(type, part), type);
    end

    function learn(self, typedefs, key)
      % Know what rosapi tells of a type, under a key, and of all types that it holds.
      known = self.Known;
      for place = 1:numel(typedefs)
        layout = self.layout_of(typedefs(place));
        known([short(typedefs(place).type) ' ']) = layout;
        if place == 1 && ~isempty(key)
          known(key) = layout;
        end
      end
    end
  end
  methods (Access = private)
    function layout = find(self, type, part)
      key = [short(type) ' ' part];
      if ~isKey(self.Known, key)
        self.ask(key, type, part);
      end
      layout = self.Known(key);
    end

    function layout = inner(self, type)
      layout = self.Known([short(type) ' ']);
    end

    function ask(self, key, type, part)
      switch part
        case ''
          service = '/rosapi/message_details';
        case {'request', 'response'}
          service = sprintf('/rosapi/service_%s_details', part);
        otherwise
          service = sprintf('/rosapi/action_%s_details', part);
      end
      told = self.Bridge.call(service, sprintf('{"type":%s}', jsonencode(type)), 10);
      self.learn(told.typedefs, key);
    end

    function layout = layout_of(self, told)
      layout.ros = reshape(cellstr_of(told.fieldnames), 1, []);
      layout.types = cellstr_of(told.fieldtypes);
      layout.lengths = told.fieldarraylen;
      layout.fields = layout.ros;
      if strcmp(self.Names, 'matlab')
        layout.fields = cellfun(@capital, layout.ros, 'UniformOutput', false);
      end
      layout.holds = ~cellfun(@isempty, strfind(layout.types, '/'));
    end

    function value = made(self, layout, type)
      value = struct();
      if nargin > 2
        value.MessageType = short(type);
      end
      for place = 1:numel(layout.ros)
        count = layout.lengths(place);
        base = layout.types{place};
        if layout.holds(place)
          one = self.made(self.inner(base));
          if count == 0
            one = [];
          elseif count > 0
            one = repmat(one, count, 1);
          end
        elseif any(strcmp(base, {'string', 'wstring'}))
          one = '';
          if count >= 0
            one = repmat({''}, count, 1);
          end
        elseif any(strcmp(base, {'bool', 'boolean'}))
          one = false(max(count, -count), 1);
        elseif count >= 0 && is_bytes(base)
          one = zeros(count, 1, 'uint8');
        else
          one = zeros(max(count, -count), 1);
        end
        value.(layout.fields{place}) = one;
      end
    end

    function value = read(self, plain, layout)
      values = cell(numel(layout.ros), 1);
      for place = 1:numel(layout.ros)
        one = [];
        if isfield(plain, layout.ros{place})
          one = plain.(layout.ros{place});
        end
        base = layout.types{place};
        if layout.holds(place)
          within = self.inner(base);
          if layout.lengths(place) < 0
            one = self.read(one, within);
          elseif ~isempty(one)
            if ~iscell(one)
              one = num2cell(one);
            end
            one = reshape(cellfun(@(each) self.read(each, within), one), [], 1);
          end
        elseif layout.lengths(place) >= 0
          if is_bytes(base) && ischar(one)
            one = reshape(uint8(matlab.net.base64decode(one)), [], 1);
          elseif any(strcmp(base, {'string', 'wstring'}))
            one = reshape(cellstr_of(one), [], 1);
          else
            one = reshape(one, [], 1);
          end
        elseif isempty(one) && ~ischar(one)
          one = NaN;  % JSON has no number for it
        end
        values{place} = one;
      end
      value = cell2struct(values, layout.fields, 1);
    end

    function text = written(self, value, layout, type)
      if ~isstruct(value) || numel(value) ~= 1
        error('virtualrobot:message', '%s: a struct belongs here, such as rosmessage gives', type);
      end
      given = fieldnames(value);
      wrong = setdiff(given, [layout.fields, {'MessageType'}]);
      if ~isempty(wrong)
        error('virtualrobot:message', '%s has no field ''%s''; it has %s', type, wrong{1}, strjoin(layout.fields, ', '));
      end
      parts = {};
      for place = 1:numel(layout.ros)
        if isfield(value, layout.fields{place})
          one = value.(layout.fields{place});
          where = [type '.' layout.fields{place}];
          parts{end + 1} = ['"' layout.ros{place} '":' self.field(one, layout, place, where)];
        end
      end
      text = ['{' strjoin(parts, ',') '}'];
    end

    function text = field(self, one, layout, place, where)
      base = layout.types{place};
      many = layout.lengths(place) >= 0;
      if layout.holds(place)
        within = self.inner(base);
        if ~many
          text = self.written(one, within, where);
        elseif iscell(one)
          text = list(cellfun(@(each) self.written(each, within, where), one, 'UniformOutput', false));
        else
          text = list(arrayfun(@(each) self.written(each, within, where), one, 'UniformOutput', false));
        end
      elseif any(strcmp(base, {'string', 'wstring'}))
        if many
          text = list(cellfun(@(each) jsonencode(char(each)), cellstr_of(one), 'UniformOutput', false));
        else
          text = jsonencode(char(one));
        end
      elseif ~isnumeric(one) && ~islogical(one) || ~many && numel(one) ~= 1
        error('virtualrobot:message', '%s: %s belongs here, not %s', where, base, class(one));
      elseif any(strcmp(base, {'bool', 'boolean'}))
        words = {'false', 'true'};
        text = words((one(:)' ~= 0) + 1);
        if many
          text = list(text);
        else
          text = text{1};
        end
      elseif many && is_bytes(base)
        text = ['"' matlab.net.base64encode(uint8(one(:)')) '"'];
      else
        text = sprintf('%.17g,', double(one));
        text = regexprep(text(1:end - 1), '-?(NaN|Inf)', 'null');
        if many
          text = ['[' text ']'];
        end
      end
    end
  end
end

function text = short(type)
% The name of a type as ROS 1 has it, by which both forms are one.
  parts = strsplit(type, '/');
  text = strjoin(parts([1, end]), '/');
end

function name = capital(name)
  parts = strsplit(name, '_');
  for place = 1:numel(parts)
    if ~isempty(parts{place})
      parts{place}(1) = upper(parts{place}(1));
    end
  end
  name = [parts{:}];
end

function texts = cellstr_of(value)
  if iscell(value)
    texts = value;
  elseif isempty(value)
    texts = {};
  else
    texts = cellstr(value);
  end
end

function text = list(parts)
  text = ['[' strjoin(reshape(parts, 1, []), ',') ']'];
end

function is = is_bytes(base)
  is = any(strcmp(base, {'uint8', 'byte', 'char', 'octet'}));
end
