"""All of a policy's results as one page.

parts (which commands) -> collect (their results, found or measured) -> sections (what they say) -> page
"""
