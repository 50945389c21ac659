function seconds = now()
% NOW  Seconds of a clock that only goes forward; its begin has no meaning.
  persistent began
  if isempty(began)
    began = tic;
  end
  seconds = toc(began);
end
