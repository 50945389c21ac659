function rosspin(seconds)
% ROSSPIN  Wait so long, while functions of subscribers are called and services of one's own answer.
  bridge = virtualrobot.session();
  deadline = virtualrobot.now() + seconds;
  while virtualrobot.now() < deadline
    bridge.pump(deadline);
  end
end
