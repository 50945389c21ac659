"""`closed_form`: all postures of an arm of up to six turning joints at once, by the library EAIK."""
