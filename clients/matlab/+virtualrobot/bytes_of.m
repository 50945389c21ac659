function bytes = bytes_of(text)
% BYTES_OF  A text as bytes in UTF-8, a row of uint8.
  persistent is_octave
  if isempty(is_octave)
    is_octave = exist('OCTAVE_VERSION', 'builtin') ~= 0;
  end
  if is_octave
    bytes = uint8(text);
  else
    bytes = unicode2native(text, 'UTF-8');
  end
end
