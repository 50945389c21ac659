function text = words(value)
% WORDS  What a server says of a failure, as text.
  if ischar(value)
    text = value;
  else
    text = jsonencode(value);
  end
end
