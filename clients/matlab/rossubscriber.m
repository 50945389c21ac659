function sub = rossubscriber(topic, varargin)
% ROSSUBSCRIBER  A subscriber of a topic.
%   sub = rossubscriber('/odom')
%   sub = rossubscriber('/odom', 'nav_msgs/Odometry')      a topic that may come later
%   sub = rossubscriber('/odom', @heard)                   heard(sub, message) is called for each message,
%                                                          while receive, rosspin or another call waits
%   message = receive(sub, 3)                              the next message; an error after 3 s without one
  sub = virtualrobot.Subscriber(topic, varargin{:});
end
