"""What every reader of a file from outside uses: bounded bytes, text, numbers, columns, blocks, XML."""
