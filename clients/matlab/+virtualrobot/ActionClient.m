classdef ActionClient < handle
% ACTIONCLIENT  What rosactionclient gives; its help tells how it is used.
  properties
    ActionName = '';
    ActionType = '';
    FeedbackFcn = [];
    GoalState = 'none';
  end
  properties (Access = private)
    Bridge = [];
    Goal = '';
  end
  methods
    function self = ActionClient(action, type)
      self.ActionName = char(action);
      self.Bridge = virtualrobot.session();
      if nargin < 2
        type = rosaction('type', self.ActionName);
      end
      self.ActionType = char(type);
      self.Bridge.Types.blank(self.ActionType, 'goal');
      self.Bridge.Types.blank(self.ActionType, 'feedback');
    end

    function there = waitForServer(self, timeout)
      % Wait until the action is there; false, or an error where nothing is asked for, when it is not in time.
      deadline = virtualrobot.now() + timeout;
      there = any(strcmp(rosaction('list'), self.ActionName));
      while ~there && virtualrobot.now() < deadline
        rosspin(0.1);
        there = any(strcmp(rosaction('list'), self.ActionName));
      end
      if ~there && nargout == 0
        error('virtualrobot:timeout', 'the action %s is not there within %g s', self.ActionName, timeout);
      end
    end

    function sendGoal(self, goal)
      % Send a goal; one that is under way already is cancelled.
      types = self.Bridge.Types;
      text = types.encode(goal, self.ActionType, 'goal');
      self.cancelGoal();
      self.Goal = self.Bridge.new_id('goal');
      self.GoalState = 'active';
      goals = self.Bridge.Goals;
      goals(self.Goal) = @(plain) self.client_hears(plain);
      self.Bridge.tell(sprintf(['{"op":"send_action_goal","id":"%s","action":%s,"action_type":%s,' ...
                                '"feedback":true,"args":%s}'], self.Goal, jsonencode(self.ActionName), ...
                               jsonencode(self.ActionType), text));
    end

    function [result, state, text] = waitForResult(self, timeout)
      % The result of the goal, and 'succeeded', 'canceled' or 'aborted'; an error virtualrobot:timeout without one.
      if nargin < 2
        timeout = Inf;
      end
      reply = self.Bridge.reply(self.Goal, timeout, self.ActionName);
      remove(self.Bridge.Goals, self.Goal);
      self.Goal = '';
      text = '';
      result = [];
      if reply.result
        result = self.Bridge.Types.decode(reply.values, self.ActionType, 'result');
      else
        text = virtualrobot.words(reply.values);
      end
      states = {'succeeded', 'canceled', 'aborted'};
      self.GoalState = states{max(reply.status, 4) - 3};
      state = self.GoalState;
    end

    function [result, state, text] = sendGoalAndWait(self, goal, varargin)
      % Send a goal and wait for its result.
      self.sendGoal(goal);
      [result, state, text] = self.waitForResult(varargin{:});
    end

    function cancelGoal(self)
      % Cancel the goal that is under way; without one nothing happens.
      if ~isempty(self.Goal) && ~self.Bridge.is_answered(self.Goal)
        self.Bridge.tell(sprintf('{"op":"cancel_action_goal","id":"%s","action":%s}', self.Goal, ...
                                 jsonencode(self.ActionName)));
      end
    end

    function type = type_name(self)
      type = self.ActionType;
    end
  end
  methods (Access = private)
    function client_hears(self, plain)
      if ~isempty(self.FeedbackFcn)
        self.FeedbackFcn(self, self.Bridge.Types.decode(plain, self.ActionType, 'feedback'));
      end
    end
  end
end
