"""Curves of CAD files (VDA-FS, IGES, STEP) as ways that a tool can follow."""
