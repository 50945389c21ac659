function [pub, message] = rospublisher(topic, varargin)
% ROSPUBLISHER  A publisher of a topic.
%   [pub, message] = rospublisher('/cmd_vel')
%   pub = rospublisher('/talk', 'std_msgs/String')
%   message.Linear.X = 0.2;
%   send(pub, message)
  pub = virtualrobot.Publisher(topic, varargin{:});
  if nargout > 1
    message = rosmessage(pub);
  end
end
