function type = service_type(service)
% SERVICE_TYPE  The type of a service; an error virtualrobot:name where there is none.
  found = virtualrobot.ask('service_type', 'type', 'service', service);
  if isempty(found)
    error('virtualrobot:name', 'there is no service ''%s''; rosservice list tells them', service);
  end
  type = found{1};
end
