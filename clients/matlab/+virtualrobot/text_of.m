function text = text_of(bytes)
% TEXT_OF  The text that bytes in UTF-8 are, as jsondecode takes it: MATLAB has letters, Octave bytes.
  persistent is_octave
  if isempty(is_octave)
    is_octave = exist('OCTAVE_VERSION', 'builtin') ~= 0;
  end
  if is_octave
    text = char(bytes);
  else
    text = native2unicode(bytes, 'UTF-8');
  end
end
