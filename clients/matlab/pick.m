function pick(file)
% PICK  The picking program in MATLAB and Octave: an arm measures a part, picks it up, swings it into a post, and is told.
%   pick('clients/cell.yaml')
% Calls go by HTTP to `virtualrobot console`: VIRTUALROBOT_CONSOLE says where (default http://127.0.0.1:8090), and
% VIRTUALROBOT_TOKEN who asks (none for a kernel with --no-token).
  info = ask('KernelService/GetInfo', struct());
  fprintf('kernel: %s\n', info.api_version);
  ask('SceneService/LoadScene', struct('text', fileread(file)));
  fprintf('measured: %.2f m\n', measured());

  above = to_pose([0.5 0.0 0.2]);
  plan = ask('MotionService/PlanMotion', struct('spec', spec(above)));
  fprintf('planned: %.2f s\n', plan.duration_seconds);
  motion = await_end(start(above));
  fprintf('moved: %s\n', strrep(motion.phase, 'MOTION_PHASE_', ''));
  await_end(start(straight_to([0.5 0.0 0.08])));
  command.pick_part = struct('robot', 'arm', 'part', 'part');
  ask('SceneService/Apply', struct('commands', {{command}}));
  await_end(start(straight_to([0.5 0.0 0.28])));
  fprintf('picked: the part is at %.2f m\n', height('part'));
  fprintf('measured: %.2f m\n', measured());

  % A watch would never end: what touches is asked for again and again.
  swing = start(to_joint('lbr_iiwa_joint_1', pi / 2));
  pairs = [];
  while isempty(pairs)
    pairs = ask('CollisionService/CheckCollision', struct('robots', {{'arm'}})).pairs;
  end
  names = sort({pairs(1).first, pairs(1).second});
  fprintf('touching: %s and %s\n', names{:});
  await_end(swing);

  try
    start(to_joint('lbr_iiwa_jiont_4', 0.5));
  catch refusal
    if ~strcmp(refusal.identifier, 'virtualrobot:UNKNOWN_NAME')
      rethrow(refusal);
    end
    fprintf('refused: %s\n', refusal.message);
  end
end

function answer = ask(method, request)
  % The answer of a call (struct); an error virtualrobot:REASON where it is refused.
  url = getenv('VIRTUALROBOT_CONSOLE');
  if isempty(url)
    url = 'http://127.0.0.1:8090';
  end
  options = weboptions('HeaderFields', {'Authorization', ['Bearer ' getenv('VIRTUALROBOT_TOKEN')]}, 'Timeout', 60);
  answer = webwrite([url '/virtualrobot.v1.' method], 'json', jsonencode(request), options);
  if ischar(answer)
    answer = jsondecode(answer);
  end
  if isfield(answer, 'error')
    refusal = answer.error;
    if isfield(refusal, 'details') && ~isempty(refusal.details) && isfield(refusal.details(1).debug, 'reason')
      why = refusal.details(1).debug;
      if isfield(why.metadata, 'nearest')
        error(['virtualrobot:' why.reason], '%s, nearest is %s', why.reason, why.metadata.nearest);
      end
      error(['virtualrobot:' why.reason], '%s', refusal.message);
    end
    error('virtualrobot:refused', '%s', refusal.message);
  end
end

function motion = start(move)
  % Nobody watches by HTTP: the motion goes on without.
  request = struct('spec', spec(move), 'on_disconnect', 'DISCONNECT_POLICY_CONTINUE');
  motion = ask('MotionService/StartMotion', request).motion;
end

function motion = await_end(motion)
  while ~any(strcmp(motion.phase, {'MOTION_PHASE_SUCCEEDED', 'MOTION_PHASE_CANCELLED', 'MOTION_PHASE_ABORTED'}))
    pause(0.02);
    motion = ask('MotionService/GetMotion', struct('id', motion.id)).motion;
  end
end

function wanted = spec(move)
  wanted = struct('moves', {{move}});
end

function goal = pose(position)
  % A goal in the world, in meters, with the tool pointing down.
  turned = struct('x', sqrt(0.5), 'y', sqrt(0.5));
  at = struct('x', position(1), 'y', position(2), 'z', position(3));
  goal.reference_t_tcp = struct('position', at, 'orientation', turned);
end

function move = to_pose(position)
  move = struct('robot', 'arm', 'point_to_point', struct('pose', pose(position)));
end

function move = straight_to(position)
  move = struct('robot', 'arm', 'linear', struct('goal', pose(position)));
end

function move = to_joint(name, radians)
  joints.joint_positions = struct(name, radians);
  move = struct('robot', 'arm', 'point_to_point', struct('joints', joints));
end

function meters = measured()
  reading = ask('SensorService/ReadSensor', struct('sensor', 'eye')).reading;
  meters = typecast(bytes(reading.range.distances), 'single');
end

function meters = height(node)
  % That of a node in the world: a row is x, y, z and a quaternion.
  row = typecast(bytes(ask('SceneService/GetScene', struct('names', {{node}})).world_t_node), 'double');
  meters = row(3);
end

function raw = bytes(array)
  raw = matlab.net.base64decode(array.data);
end
