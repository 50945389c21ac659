"""`virtualrobot topic`: streams of a world, heard, measured, plotted, told and played again."""
