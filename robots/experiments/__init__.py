"""The papers' tables and figures measured again, one module each; ours is printed beside theirs."""
