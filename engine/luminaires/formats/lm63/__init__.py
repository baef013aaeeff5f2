"""IES LM-63 (.ies): read by `reader`, written by `writer`."""
