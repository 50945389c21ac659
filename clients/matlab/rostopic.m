function told = rostopic(verb, topic)
% ROSTOPIC  `rostopic list`, `rostopic info TOPIC`, `rostopic type TOPIC`, `rostopic echo TOPIC` (one message).
  verbs = {'list', 'info', 'type', 'echo'};
  if nargin < 1 || ~any(strcmp(verb, verbs)) || (nargin < 2) ~= strcmp(verb, 'list')
    error('virtualrobot:usage', 'rostopic list, or rostopic info|type|echo TOPIC');
  end
  switch verb
    case 'list'
      found = virtualrobot.show(sort(virtualrobot.ask('topics', 'topics')), nargout > 0);
    case 'type'
      found = virtualrobot.topic_type(topic);
      if nargout == 0
        fprintf('%s\n', found);
      end
    case 'info'
      found.Type = virtualrobot.topic_type(topic);
      found.Publishers = virtualrobot.ask('publishers', 'publishers', 'topic', topic);
      found.Subscribers = virtualrobot.ask('subscribers', 'subscribers', 'topic', topic);
      if nargout == 0
        fprintf('Type: %s\n\nPublishers:\n', found.Type);
        fprintf('* %s\n', found.Publishers{:});
        fprintf('\nSubscribers:\n');
        fprintf('* %s\n', found.Subscribers{:});
      end
    case 'echo'
      found = receive(rossubscriber(topic), 10);
      if nargout == 0
        disp(found);
      end
  end
  if nargout > 0
    told = found;
  end
end
