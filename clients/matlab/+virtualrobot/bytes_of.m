function bytes = bytes_of(text)
% BYTES_OF  A text as bytes in UTF-8, a row of uint8.
  if exist('OCTAVE_VERSION', 'builtin')
    bytes = uint8(text);
  else
    bytes = unicode2native(text, 'UTF-8');
  end
end
