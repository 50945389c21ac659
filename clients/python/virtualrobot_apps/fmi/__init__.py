"""FMI: a controller that is a Functional Mock-up Unit (FMU), and a cell that is one."""
