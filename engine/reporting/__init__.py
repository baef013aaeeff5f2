"""The report of a scene for a client: its content (results), layout (composition) and files (html_file, pdf_file, data)."""
