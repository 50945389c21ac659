function [client, goal] = rosactionclient(action, varargin)
% ROSACTIONCLIENT  A client of an action.
%   [client, goal] = rosactionclient('/arm/follow_joint_trajectory')
%   [result, state, text] = sendGoalAndWait(client, goal, 10)
%   sendGoal(client, goal); ... [result, state] = waitForResult(client, 10);
%   cancelGoal(client)
% client.FeedbackFcn = @(client, feedback) ... is called while one of these waits.
  client = virtualrobot.ActionClient(action, varargin{:});
  if nargout > 1
    goal = rosmessage(client);
  end
end
