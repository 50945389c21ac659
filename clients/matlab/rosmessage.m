function message = rosmessage(type)
% ROSMESSAGE  A message of zeros: of a type, rosmessage('geometry_msgs/Twist'), or for a publisher, a subscriber,
% a client of a service (its request) or of an action (its goal).
  part = '';
  if isobject(type)
    if isa(type, 'virtualrobot.ServiceClient')
      part = 'request';
    elseif isa(type, 'virtualrobot.ActionClient')
      part = 'goal';
    end
    type = type.type_name();
  end
  bridge = virtualrobot.session();
  message = bridge.Types.blank(char(type), part);
end
