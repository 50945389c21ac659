function shown = show(lines, wanted)
% SHOW  Lines as a cell, where the caller takes it, else printed.
  shown = reshape(lines, [], 1);
  if ~wanted
    fprintf('%s\n', shown{:});
  end
end
