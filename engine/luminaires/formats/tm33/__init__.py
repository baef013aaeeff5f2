"""ANSI/IES TM-33 and UNI 11733 (XML): read by `reader`."""
