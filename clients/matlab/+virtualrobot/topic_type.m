function type = topic_type(topic)
% TOPIC_TYPE  The type of a topic; an error virtualrobot:name where there is none.
  found = virtualrobot.ask('topic_type', 'type', 'topic', topic);
  if isempty(found)
    error('virtualrobot:name', 'there is no topic ''%s''; rostopic list tells them', topic);
  end
  type = found{1};
end
