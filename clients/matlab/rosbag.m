function bag = rosbag(file, varargin)
% ROSBAG  A bag of ROS 1 (.bag) or ROS 2 (.mcap, .db3, a folder); such as `virtualrobot ros --record run.mcap` writes.
%   bag = rosbag('run.mcap')
%   bag.AvailableTopics(1)                                  topic, type, count
%   odom = select(bag, 'Topic', '/ugv/odom', 'Time', [2 5])
%   messages = readMessages(odom)                           a cell of structs; times: odom.Times
% It is read by Python with virtualrobot[ros]: python3, or rosbag(file, 'Python', 'C:\...\python.exe').
% rosbag(..., 'FieldNames', 'ros') calls fields as in ROS.
  bag = virtualrobot.Bag(file, varargin{:});
end
