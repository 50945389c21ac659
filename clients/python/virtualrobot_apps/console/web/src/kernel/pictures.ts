// Beats of the page's pictures: what is held is held as long as the page draws, so that one that hangs, is hidden or is gone
// lets go. No timer beats.

/** Calls `beat` now, and with each picture of the page, until the returned function is called. */
export function eachPicture(beat: () => void): () => void {
  let asked = 0;
  const next = () => {
    asked = requestAnimationFrame(next);
    beat();
  };
  next();
  return () => cancelAnimationFrame(asked);
}
