function rosshutdown()
% ROSSHUTDOWN  End the connection that rosinit has opened; subscribers and publishers end with it.
  try
    bridge = virtualrobot.session();
  catch
    return
  end
  bridge.close();
  virtualrobot.session([]);
  fprintf('Closed the connection to %s\n', bridge.Url);
end
