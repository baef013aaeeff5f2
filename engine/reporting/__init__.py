"""The report of a scene for a client: its content (results), its layout (composition), and its files (html_file, pdf_file, data)."""
