"""An emulated ABB controller: Robot Web Services, and RAPID that runs in the kernel's world."""
