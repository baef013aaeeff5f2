"""Why pictures of single files differ from Cycles', by the names of the files: facts that were looked into, one by one."""

REASONS: dict[str, str] = {}
