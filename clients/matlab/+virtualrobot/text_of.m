function text = text_of(bytes)
% TEXT_OF  The text that bytes in UTF-8 are, as jsondecode takes it: MATLAB has letters, Octave bytes.
  if exist('OCTAVE_VERSION', 'builtin')
    text = char(bytes);
  else
    text = native2unicode(bytes, 'UTF-8');
  end
end
