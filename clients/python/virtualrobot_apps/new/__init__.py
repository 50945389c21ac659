"""Ready cells: `virtualrobot new` writes one as a start for your own."""
