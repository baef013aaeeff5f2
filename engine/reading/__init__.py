"""What every reader of a file from outside uses: bounded bytes, text, numbers, tables, XML, arrays; files written whole."""
