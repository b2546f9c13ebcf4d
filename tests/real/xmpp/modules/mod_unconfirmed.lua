-- For tests: says by HTTP how many messages with words one user would be given again.
module:depends("http");

local function count(_, user)
	local found = 0;
	local account = prosody.hosts[module.host].sessions[user];
	for _, session in pairs(account and account.sessions or {}) do
		for _, stanza in pairs(session.outgoing_stanza_queue and session.outgoing_stanza_queue:table() or {}) do
			if stanza.name == "message" and stanza:get_child("body") then
				found = found + 1;
			end
		end
	end
	return tostring(found);
end

module:provides("http", { default_path = "/unconfirmed"; route = { ["GET /*"] = function(event, user) return count(event, user); end } });
